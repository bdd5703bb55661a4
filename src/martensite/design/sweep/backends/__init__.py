"""Executors of the chunks of a sweep: this process, several processes, or a cluster."""
