"""The algorithm of [HHdD16 impl.] as it is printed, with its thresholds, fits and searches."""
