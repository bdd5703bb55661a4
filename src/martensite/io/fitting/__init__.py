"""From scenarios and logs to a fit: what is asked for, what is compared, steps, checks, files."""
