"""The controls on the page, one file per subject."""
