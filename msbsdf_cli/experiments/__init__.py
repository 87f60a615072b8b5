"""Experiments: settings in, result out; they know no option, no path and no picture."""
