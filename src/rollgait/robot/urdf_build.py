"""A URDF as pinocchio's model, with nothing lost on the way and nothing printed."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

import numpy as np
import pinocchio as pin

from rollgait.errors import FileError, shown
from rollgait.robot.urdf_files import Urdf

ROUNDED: Final = 0.02
"""Share by which principal moments may miss the triangle inequality: URDFs are written in few digits."""

REASON_MAX: Final = 200
"""Most characters of the parser's own words in a message."""

_ERROR: Final = "Error:"
"""Begins a line in which the parser says what it has not understood, and goes on without."""

_STDERR: Final = 2


def build_model(urdf: Urdf) -> Any:
    """Pinocchio's model of a URDF with a free base; links that are welded together have become one body.

    Raises:
        FileError: the parser does not understand it all, or a body that moves has no mass or an inertia that
            no body has.
    """
    reasons: list[str] = []
    model = None
    with _captured_stderr() as lines:
        try:
            model = pin.buildModelFromXML(urdf.text, pin.JointModelFreeFlyer())
        except (ValueError, RuntimeError) as error:
            reasons = str(error).split("\n")
    reasons = [line.removeprefix(_ERROR).strip() for line in lines if line.startswith(_ERROR)] + reasons
    if model is None or reasons:
        raise FileError("urdf", str(urdf.path), f"is not understood: {reasons[0][:REASON_MAX]}")
    _check_bodies(urdf, model)
    return model


def _check_bodies(urdf: Urdf, model: Any) -> None:
    """Judges each body with all that is welded to it: alone, a frame or a camera may well be without mass."""
    for name, body in zip(model.names[1:], list(model.inertias)[1:], strict=True):
        joint = urdf.joints.get(name)
        link = urdf.root_link if joint is None else joint.child
        begin = f"has the link {shown(link)}, which with all that is welded to it"
        if body.mass <= 0.0:
            raise FileError("urdf", str(urdf.path), f"{begin} must have a mass greater than 0 kg")
        a, b, c = np.linalg.eigvalsh(body.inertia)
        if a <= 0.0 or a + b < c * (1.0 - ROUNDED):
            moments = (
                f"must have the inertia of a body: its principal moments {a:.3g}, {b:.3g}, {c:.3g} kg·m²"
            )
            rule = f"{moments} must be positive and none may exceed the sum of the two others"
            raise FileError("urdf", str(urdf.path), f"{begin} {rule}")


@contextmanager
def _captured_stderr() -> Iterator[list[str]]:
    """The lines that libraries write past Python to stderr; the list is filled when the block ends."""
    lines: list[str] = []
    sys.stderr.flush()
    with tempfile.TemporaryFile() as caught:
        terminal = os.dup(_STDERR)
        os.dup2(caught.fileno(), _STDERR)
        try:
            yield lines
        finally:
            os.dup2(terminal, _STDERR)
            os.close(terminal)
            caught.seek(0)
            lines += caught.read().decode(errors="replace").splitlines()
