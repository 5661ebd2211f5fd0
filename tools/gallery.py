"""Builds docs/gallery: the four motions as pictures, recordings and numbers. Run by `make gallery`."""

from __future__ import annotations

import sys
from pathlib import Path

import rollgait
from rollgait.plan.plan import Plan
from rollgait.view.clip import Clip, clip_of_plan
from rollgait.view.figures import figure
from rollgait.view.recording import record_page
from rollgait.view.style import find_style
from rollgait.view.video import record_gif, still

FOLDER = Path(__file__).parents[1] / "docs" / "gallery"
SIZE = (1120, 630)
"""Of the pictures, pixels."""
MOMENT = 0.5
"""When the picture is taken, as a share of the horizon."""
HEAD = """# Gallery

The four motions that come with rollgait, planned, judged and drawn by `make gallery`. The same command builds
pages that open offline and can be turned and scrubbed; they are not kept in the repository.
"""


def main() -> None:
    """Plans, draws and describes every motion."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    parts = [HEAD]
    for name in rollgait.scenario_names():
        print(name, flush=True)
        plan = rollgait.plan(name)
        if not plan.certificate().passed:
            sys.exit(f"error: {name} is not certified")
        clip = clip_of_plan(plan, name)
        _draw(plan, clip)
        parts.append(_describe(plan, clip))
    (FOLDER / "README.md").write_text("\n".join(parts), encoding="utf-8")


def _draw(plan: Plan, clip: Clip) -> None:
    still(clip, MOMENT * clip.horizon, SIZE).save(FOLDER / f"{clip.name}.png", optimize=True)
    record_gif(clip, FOLDER / f"{clip.name}.gif")
    record_page(clip, FOLDER / f"{clip.name}.html")
    with find_style("screen").applied():
        figure(plan, "forces").savefig(
            FOLDER / f"{clip.name}-forces.png", dpi=80, metadata={"Software": None}
        )


def _describe(plan: Plan, clip: Clip) -> str:
    s, goal = plan.statistics, clip.goals[-1].pose
    end = plan.sample(plan.horizon)
    miss = 1000.0 * float(((end.com_position[:2] - goal[:2]) ** 2).sum() ** 0.5)
    tightest = clip.marks[0]
    rows = [
        ("what", plan.scenario.description),
        ("horizon", f"{plan.horizon:g} s, {len(list(plan.schedule.swings()))} steps"),
        (
            "solver",
            f"{s.solver}, {s.iterations} iterations, {s.variables} variables, {s.constraints} constraints",
        ),
        ("certificate", f"passed, {len(plan.certificate().rows)} rows"),
        ("nearest to a limit", f"{tightest.label}: {tightest.value}"),
        ("distance from the goal at the end", f"{miss:.2g} mm"),
        ("cost", f"{s.cost:.5g}"),
    ]
    table = "\n".join(f"| {key} | {value} |" for key, value in rows)
    name = clip.name
    return (
        f"## {name}\n\n![{name}, moving]({name}.gif)\n\n| | |\n|---|---|\n{table}\n\n"
        f"[picture]({name}.png), [contact forces]({name}-forces.png), page: `{name}.html`\n"
    )


if __name__ == "__main__":
    main()
