"""Builds docs/gallery: the library's motions as pictures, recordings and numbers. Run by `make gallery`.

On ground that is not flat a motion is a picture and the profile of its ground: moving pictures would be many
MB.
"""

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

The motions that come with rollgait, planned, judged and drawn by `make gallery`: those on flat ground, then
those on [terrain](../terrain.md). The same command builds pages that open offline and can be turned and
scrubbed; they are not kept in the repository.
"""


def main() -> None:
    """Plans, draws and describes every motion."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    parts = [HEAD]
    for name in sorted(rollgait.scenario_names(), key=lambda name: not _is_flat(name)):
        print(name, flush=True)
        plan = rollgait.plan(name)
        if not plan.certificate().passed:
            sys.exit(f"error: {name} is not certified")
        clip = clip_of_plan(plan, name)
        _draw(plan, clip)
        parts.append(_describe(plan, clip))
    (FOLDER / "README.md").write_text("\n".join(parts), encoding="utf-8")


def _is_flat(name: str) -> bool:
    return rollgait.find_scenario(name).ground.kind == "flat"


def _draw(plan: Plan, clip: Clip) -> None:
    still(clip, MOMENT * clip.horizon, SIZE).save(FOLDER / f"{clip.name}.png", optimize=True)
    record_page(clip, FOLDER / f"{clip.name}.html")
    if _is_flat(clip.name):
        record_gif(clip, FOLDER / f"{clip.name}.gif")
    with find_style("screen").applied():
        kind = _figure(clip.name)
        figure(plan, kind).savefig(FOLDER / f"{clip.name}-{kind}.png", dpi=80, metadata={"Software": None})


def _figure(name: str) -> str:
    """What says most of a motion beside its picture: its forces, or the ground under its feet."""
    return "forces" if _is_flat(name) else "profile"


def _describe(plan: Plan, clip: Clip) -> str:
    s, goal = plan.statistics, clip.goals[-1].pose
    end = plan.sample(plan.horizon)
    miss = 1000.0 * float(((end.com_position[:2] - goal[:2]) ** 2).sum() ** 0.5)
    tightest = clip.marks[0]
    rounds = "" if s.ground_rounds == 1 else f" in {s.ground_rounds} rounds about the ground"
    effort = f"{s.iterations} iterations{rounds}"
    rows = [
        ("what", plan.scenario.description),
        ("horizon", f"{plan.horizon:g} s, {len(list(plan.schedule.swings()))} steps"),
        ("solver", f"{s.solver}, {effort}, {s.variables} variables, {s.constraints} constraints"),
        ("certificate", f"passed, {len(plan.certificate().rows)} rows"),
        ("nearest to a limit", f"{tightest.label}: {tightest.value}"),
        ("distance from the goal at the end", f"{miss:.2g} mm"),
        ("cost", f"{s.cost:.5g}"),
    ]
    table = "\n".join(f"| {key} | {value} |" for key, value in rows)
    name = clip.name
    if _is_flat(name):
        shown = f"![{name}, moving]({name}.gif)"
        more = f"[picture]({name}.png), [contact forces]({name}-forces.png)"
    else:
        shown = f"![{name}]({name}.png)"
        more = f"[ground under the feet]({name}-profile.png)"
    return f"## {name}\n\n{shown}\n\n| | |\n|---|---|\n{table}\n\n{more}, page: `{name}.html`\n"


if __name__ == "__main__":
    main()
