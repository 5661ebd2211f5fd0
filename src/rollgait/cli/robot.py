"""`rollgait robot import`: a robot for the planner from a URDF."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollgait.cli.arguments import AsJson
from rollgait.cli.output import print_json, print_table
from rollgait.cli.usage import Commands
from rollgait.config import dump_yaml
from rollgait.errors import FileError, MissingExtraError
from rollgait.files import check_writable, replacing
from rollgait.robot.whole_body import EXTRA, WholeBody, library_whole_body, load_whole_body

app = typer.Typer(cls=Commands, rich_markup_mode=None, help="Make robots for the planner.")


@app.callback()
def robot() -> None:
    """Make robots for the planner."""


@app.command("import")
def import_(
    model: Annotated[
        str,
        typer.Argument(
            metavar="MODEL",
            help="A .urdf, the .yaml that describes one, or the name of a robot in the library.",
        ),
    ],
    legs: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Names the legs' frames and joints. Default: MODEL with .yaml."),
    ] = None,
    srdf: Annotated[Path | None, typer.Option(metavar="FILE", help="SRDF with the posture.")] = None,
    posture: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Group state of the SRDF from which the stance is derived."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write the robot (.yaml).")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Derive a robot for the planner from a URDF: say what was found, and what had to be chosen.

    Mass, inertia, nominal stance, foot kinds, limits, reach and workspace come from the URDF and inverse
    kinematics. A small YAML file beside it names each leg's wheel or foot and its joints: docs/whole-body.md.
    """
    if out is not None:
        check_writable(out)
    described, body = _whole_body(model, legs)
    changes = {"srdf": srdf and str(_existing("srdf", srdf)), "posture": posture}
    body = body.model_copy(update={key: value for key, value in changes.items() if value is not None})
    try:
        import pinocchio  # noqa: F401
    except ImportError:
        raise MissingExtraError("importing a URDF", EXTRA) from None
    from rollgait.robot.urdf import import_robot

    found = import_robot(body, None if described is None else str(described.absolute()))
    data = found.robot.model_dump(mode="json", exclude_none=True)
    if out is not None:
        with replacing(out) as temporary:
            temporary.write_text(dump_yaml(data), encoding="utf-8")
    if as_json:
        facts = [
            {"name": f.name, "value": f.value, "source": f.source, "known": f.known} for f in found.findings
        ]
        print_json({"file": None if out is None else str(out), "robot": data, "findings": facts})
        return
    for title, known in (("found", True), ("not in the URDF: chosen or default", False)):
        print(title)
        print_table([(f.name, f.value, f.source) for f in found.findings if f.known == known])
        print()
    if out is None:
        print("--out robot.yaml writes it")
    else:
        print(f"written: {out}")
        print(f"next:    rollgait plan hybrid-forward --set robot={out}")


def _whole_body(model: str, legs: Path | None) -> tuple[Path | None, WholeBody]:
    """The file that describes the whole body (None for one of the library), and what it says."""
    path = Path(model)
    if path.suffix in (".yaml", ".yml"):
        return path, load_whole_body(path)
    if path.suffix == "" and legs is None and not path.exists():
        return None, library_whole_body(model)
    _existing("urdf", path)
    file = legs or path.with_suffix(".yaml")
    if not file.is_file():
        rule = (
            "is needed to name the legs' frames and joints, and does not exist: docs/whole-body.md shows one"
        )
        raise FileError("legs", str(file), rule)
    return file, load_whole_body(file).model_copy(update={"urdf": str(path.absolute())})


def _existing(field: str, path: Path) -> Path:
    if not path.is_file():
        raise FileError(field, str(path), "cannot be read: there is no such file")
    return path.absolute()
