"""What the ground is to each foot in each interval: numbers for a problem. Knows no CasADi and no solver."""
