"""Meshes of robots that others made: all formats that their URDFs use, and files that cannot be read."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest

from rollgait.robot.whole_body import data_file
from rollgait.view.meshes import _mesh


def test_a_collada_mesh_is_read_in_metres() -> None:
    file = data_file("urdf", "example-robot-data:hyq_description/meshes/trunk/trunk.dae")
    shape = _mesh(file, (1.0, 1.0, 1.0))
    assert shape is not None
    assert 0.5 < np.ptp(shape[0], axis=0).max() < 1.5  # HyQ is a metre long


@pytest.mark.parametrize("suffix", [".dae", ".stl", ".obj", ".odd"])
def test_a_mesh_that_cannot_be_read_is_told_and_left_out(
    suffix: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = tmp_path / f"broken{suffix}"
    file.write_bytes(b"\x00 no mesh \xff" * 20)
    with caplog.at_level(logging.WARNING, logger="rollgait"):
        assert _mesh(file, (1.0, 1.0, 1.0)) is None
    assert f"broken{suffix} cannot be read and is not drawn" in caplog.text
