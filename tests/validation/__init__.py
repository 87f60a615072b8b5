"""Every identity can fail: the formula it guards is bent, and its verdict must turn."""
