"""Studies: each source paper rebuilt, one folder per paper, its numbers beside ours."""
