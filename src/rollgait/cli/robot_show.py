"""`rollgait robot show`: a robot of the library, or of a file."""

from __future__ import annotations

from rollgait.cli.arguments import AsJson, RobotName
from rollgait.cli.output import print_json

_HEADER = """\
# {name}: a complete robot. Edit it and plan with it: rollgait plan SCENARIO --set robot=FILE.yaml
"""


def show(robot: RobotName, as_json: AsJson = False) -> None:
    """Print a complete robot as YAML.

    Every default is spelled out: the way to start one's own. For example:
    rollgait robot show centauro > mine.yaml
    """
    from rollgait.config import dump_yaml
    from rollgait.robot import find_robot

    data = find_robot(robot).model_dump(mode="json", exclude_none=True)
    if as_json:
        print_json(data)
    else:
        print(_HEADER.format(name=robot) + dump_yaml(data), end="")
