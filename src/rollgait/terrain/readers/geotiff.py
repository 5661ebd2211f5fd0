"""Heights out of a GeoTIFF: a digital elevation model."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from rollgait.errors import MissingExtraError
from rollgait.terrain.map_file import RawMap, Source, check_cells

SQUARE: Final = 1.0e-6
"""Relative difference of the sides of a pixel that still counts as square."""


def read(source: Source) -> RawMap:
    """The first band; its transform says where each pixel is, its no-data value what is not known.

    Raises:
        FileError: it cannot be read, is too large, has no transform, pixels that are not square, or degrees.
        MissingExtraError: the extra `geotiff` is not installed.
    """
    try:
        import rasterio
        from rasterio.errors import RasterioError
    except ImportError:
        raise MissingExtraError("a map in a GeoTIFF", "geotiff") from None
    import warnings

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # NotGeoreferencedWarning: said below, in our words
            with rasterio.open(source.path, driver="GTiff") as data:
                check_cells(source, (data.width, data.height))
                if data.crs is not None and data.crs.is_geographic:
                    raise source.fault(
                        "must have a projection in metres, not longitude and latitude in degrees"
                    )
                return _placed(source, data.transform, _band(data))
    except RasterioError:
        raise source.fault("is not a GeoTIFF that can be read") from None


def _band(data: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    band = data.read(1, masked=True)
    return np.asarray(np.ma.filled(band.astype(float), np.nan))


def _placed(source: Source, transform: Any, rows: np.ndarray[Any, np.dtype[np.float64]]) -> RawMap:
    """The band in the axes of a right-handed grid, from its transform (column, row) → (x, y)."""
    if transform.is_identity:
        raise source.fault("must have a transform that says where its pixels are")
    along = np.array([transform.a, transform.d])  # from a column to the next, m
    down = np.array([transform.b, transform.e])  # from a row to the next, m
    side, other = np.linalg.norm(along), np.linalg.norm(down)
    if abs(side - other) > SQUARE * side or abs(along @ down) > SQUARE * side * other:
        raise source.fault(f"must have square pixels, not {side:g} m × {other:g} m")
    corner = np.array([transform.c, transform.f])
    first = corner + 0.5 * along + 0.5 * down  # a pixel's height stands in its middle
    if along[0] * down[1] - along[1] * down[0] < 0.0:  # as usual: rows run down, towards smaller y
        first, values = first + (len(rows) - 1) * down, rows[::-1].T
    else:
        values = rows.T
    return RawMap(values, float(side), first, float(np.arctan2(along[1], along[0])))
