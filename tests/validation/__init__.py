"""Every identity can fail: the formula it guards is faulty, and its verdict must turn."""
