"""Between the browsers and viser: who may talk to a page, and what of it is believed."""
