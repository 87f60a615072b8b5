"""Many scenes: pieces of work whose sums add up, wherever and in whatever order they are done."""
