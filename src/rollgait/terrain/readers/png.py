"""Heights as grey levels of a PNG."""

from __future__ import annotations

import warnings

import numpy as np
from PIL import Image

from rollgait.terrain.map_file import RawMap, Source, check_cells

GREY = {"I;16": "16 bit", "I;16B": "16 bit", "I": "16 bit"}
"""Modes of Pillow that hold grey levels of 16 bits; older releases read them as 32."""


def read(source: Source) -> RawMap:
    """The first row of a picture is its top, at the largest y; the lower left pixel is value [0, 0].

    Raises:
        FileError: it is no PNG of 16-bit grey levels, or too large.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(source.path, formats=["PNG"]) as picture:
                check_cells(source, picture.size)
                if picture.mode not in GREY:
                    raise source.fault(f"must hold grey levels of 16 bits, not {picture.mode}")
                rows = np.asarray(picture, dtype=float)
    except (Image.DecompressionBombWarning, Image.DecompressionBombError):
        raise source.fault("has too many pixels") from None
    except (OSError, SyntaxError, ValueError) as error:  # Pillow's words for what is damaged
        if isinstance(error, ValueError) and hasattr(error, "field"):
            raise
        raise source.fault("is not a PNG that can be read") from None
    return RawMap(rows[::-1].T, metres=False)
