"""The deterministic solution of the Smith model: nodes, discrete kernels, sums over orders."""
