"""Where each method stops working: sweeps to the ends of every parameter, and a verdict a cell."""
