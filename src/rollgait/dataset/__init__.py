"""Libraries of motions: thousands of plans, asked for by distributions, in one table that others can read."""

from typing import TYPE_CHECKING

from rollgait.lazy import lazy_names

if TYPE_CHECKING:
    from rollgait.dataset.dataset import Dataset
    from rollgait.dataset.running import plan_dataset
    from rollgait.dataset.sampler import Asked, Sampler
    from rollgait.dataset.spec import Distribution, Family, Spec

__all__ = ["Asked", "Dataset", "Distribution", "Family", "Sampler", "Spec", "plan_dataset"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "Asked": "sampler",
            "Dataset": "dataset",
            "Distribution": "spec",
            "Family": "spec",
            "Sampler": "sampler",
            "Spec": "spec",
            "plan_dataset": "running",
        },
    )
