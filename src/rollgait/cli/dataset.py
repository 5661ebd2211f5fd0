"""`rollgait dataset`: libraries of motions, from a spec to a table, its statistics and its exports."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollgait.cli.arguments import AsJson, rate_from
from rollgait.cli.output import number, print_json, print_note, print_table
from rollgait.cli.replacing import note_replacing
from rollgait.cli.usage import Commands
from rollgait.cli.verbosity import Verbosity, verbosity
from rollgait.errors import NotSolvedError, RollgaitError
from rollgait.files import check_writable, npz_path

if TYPE_CHECKING:
    from rollgait.dataset import Dataset

SPECS = (".yaml", ".yml")


class _DatasetCommands(Commands):
    """`rollgait dataset SPEC.yaml` is short for `rollgait dataset run SPEC.yaml`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if args and args[0].endswith(SPECS):
            args = ["run", *args]
        return super().parse_args(ctx, args)


app = typer.Typer(
    cls=_DatasetCommands, rich_markup_mode=None, help="Plan libraries of motions; look at them; hand them on."
)

SpecFile = Annotated[
    Path, typer.Argument(metavar="SPEC", help="What to plan: a YAML file (page 'Data sets').")
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A data set that 'rollgait dataset run' wrote.")]


@app.callback()
def dataset() -> None:
    """Plan libraries of motions; look at them; hand them on.

    Start with: rollgait dataset SPEC.yaml
    """


@app.command("run")
def run(
    spec: SpecFile,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where to write. Default: SPEC without its suffix.")
    ] = None,
    workers: Annotated[
        int, typer.Option(metavar="N", help="How many to plan at once. Default: one per core.")
    ] = -1,
    as_json: AsJson = False,
) -> None:
    """Plan the rows of a spec that are not there yet.

    Each row is kept as soon as it is planned: after Ctrl-C or a failure repeat the command. The count of the
    spec may be raised later. Goals without a plan are rows too, with the reason.

    Exit status: 0 all rows are there, 2 wrong input.
    """
    from rollgait.dataset import plan_dataset

    target = out or spec.with_suffix("")
    quiet = as_json or verbosity() is Verbosity.QUIET
    try:
        done = plan_dataset(spec, target, workers=workers, quiet=quiet)
    except KeyboardInterrupt:
        print_note(f"what is planned is kept in {target}: repeat the command to go on")
        raise
    _print_stats(done, as_json)


@app.command("stats")
def stats(
    folder: Folder,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw them, too, into a .png, .svg or .pdf.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Say what came of the rows.

    Verdicts, costs, times, margins, reasons.
    """
    from rollgait.dataset import Dataset

    found = Dataset(folder)
    if plot is not None:
        from rollgait.dataset.stats import draw
        from rollgait.view.figures import require_image_format

        require_image_format(plot)
        check_writable(plot)
        note_replacing(plot)
        print_note(f"{draw(found, plot)}")
    _print_stats(found, as_json)


@app.command("check")
def check(
    folder: Folder,
    rows: Annotated[int, typer.Option(metavar="N", min=1, help="How many random rows to certify anew.")] = 20,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed by which the rows are drawn.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Certify random rows anew, from the table alone, and count all.

    Exit status: 0 each row is there once and what was looked at is as the table says, 1 not so.
    """
    from rollgait.dataset import Dataset

    found = Dataset(folder).check(rows, seed)
    if as_json:
        print_json(found.to_dict())
    else:
        print(f"{found.there} of {found.asked} rows, {len(found.twice)} twice")
        print(f"{len(found.certified)} certified anew, {len({row for row, _ in found.wrong})} wrong")
        for row, why in found.wrong:
            print(f"  row {row}: {why}")
    if not found.passed:
        raise typer.Exit(1)


@app.command("sample")
def sample(
    spec: SpecFile,
    rows: Annotated[int, typer.Option(metavar="N", min=1, help="How many rows, from the first.")] = 10,
    as_json: AsJson = False,
) -> None:
    """Show what a spec draws, without planning it."""
    from rollgait.dataset import Sampler, Spec

    sampler = Sampler.of(Spec.from_yaml(spec), spec.parent)
    drawn = [sampler.asked(row) for row in range(min(rows, sampler.spec.count))]
    refused = {}
    for asked in drawn:
        try:
            sampler.scenario(asked)
        except RollgaitError as error:
            refused[asked.row] = str(error)
    if as_json:
        print_json(
            [
                {"row": a.row, "family": a.family, "values": dict(a.values), "refused": refused.get(a.row)}
                for a in drawn
            ]
        )
        return
    table = [("row", "family", "values")]
    for asked in drawn:
        values = ", ".join(f"{key}={_short(value)}" for key, value in asked.values.items())
        table.append((str(asked.row), asked.family, values))
        if asked.row in refused:
            table.append(("", "refused", refused[asked.row]))
    print_table(table, right=[0], indent=0)


@app.command("show")
def show(
    folder: Folder,
    row: Annotated[int, typer.Argument(metavar="ROW", help="Number of the row.")],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write its plan (.npz), for all other commands.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show one row: what was asked, what came of it, and its plan.

    Exit status: 0 it has a certified plan, 1 it has none.
    """
    from rollgait.dataset import Dataset
    from rollgait.dataset.columns import CERTIFIED

    target = None if out is None else npz_path(out, "out")
    if target is not None:
        check_writable(target)
    found = Dataset(folder)
    record = found.record(row)
    asked = found.sampler.asked(row)
    facts = {
        name: record[name] for name in ("row", "family", "status", "reason", "cost", "seconds", "nearness")
    }
    if as_json:
        rows = found.certificate(row).to_dict()["rows"] if record["certificate"] is not None else []
        print_json({**facts, "asked": dict(asked.values), "certificate": rows})
    else:
        for name, value in facts.items():
            if value not in (None, ""):
                print(f"{name:<9} {number(value, 4) if isinstance(value, float) else value}")
        for key, value in asked.values.items():
            print(f"  {key} = {_short(value)}")
        if record["certificate"] is not None:
            print(found.certificate(row))
    if target is not None:
        plan = found.plan(row)
        note_replacing(target)
        print_note(str(plan.save(target)))
    if record["status"] != CERTIFIED:
        raise typer.Exit(NotSolvedError.exit_status)


@app.command("export")
def export(
    folder: Folder,
    file_format: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="lerobot, isaaclab or mujoco.")
    ] = "lerobot",
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where to write. Default: DIR-FORMAT.")
    ] = None,
    rate: Annotated[str, typer.Option(metavar="HZ", help="Samples per second.")] = "50",
    joints: Annotated[
        bool, typer.Option("--joints", help="lerobot: of the whole body, tracked, in place of the plan.")
    ] = False,
    rows: Annotated[
        list[int] | None, typer.Option("--row", metavar="N", help="Only this row; repeatable.")
    ] = None,
) -> None:
    """Write certified motions as others load them.

    isaaclab and mujoco are of the whole body: plans are tracked first.
    """
    from rollgait.dataset import Dataset
    from rollgait.dataset.exports import export as write

    per_second = rate_from(rate)
    target = out or folder.with_name(f"{folder.name}-{file_format}")
    written = write(Dataset(folder), target, file_format, per_second, joints=joints, rows=rows)
    print(f"{target}: {written.motions} motions, {written.frames} frames")
    for row, why in written.left_out:
        print_note(f"row {row} is left out: {why}")


def _print_stats(dataset: Dataset, as_json: bool) -> None:
    found = dataset.stats()
    if as_json:
        print_json({"folder": str(dataset.folder), **found.to_dict()})
        return
    print(f"{dataset.folder}: {found.there} of {found.asked} rows, {found.bytes_per_row / 1e3:.1f} kB each")
    statuses = list(found.statuses)
    table = [("family", *statuses)]
    table += [(name, *(str(own.get(one, 0)) for one in statuses)) for name, own in found.families.items()]
    table.append(("all", *(str(found.statuses[one]) for one in statuses)))
    print_table(table, right=range(1, len(statuses) + 1))
    if found.figures:
        names = list(next(iter(found.figures.values())))
        rows = [("certified", *names)]
        rows += [(name, *(number(value) for value in own.values())) for name, own in found.figures.items()]
        print()
        print_table(rows, right=range(1, len(names) + 1))
    if found.tight:
        print()
        print_table(
            [("nearest to its limit", "median", "most")]
            + [(name, number(mid), number(most)) for name, (mid, most) in found.tight.items()],
            right=[1, 2],
        )
    for reason, times in found.reasons.items():
        print(f"  {times} × {reason}")


def _short(value: Any) -> str:
    """A value in a line: numbers plain, the rest as JSON."""
    return number(value, 5) if isinstance(value, float) else json.dumps(value)
