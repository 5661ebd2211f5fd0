"""Gaits found from ground, start and goal. Knows no CasADi and no solver."""
