"""Who runs the chunks of a sweep: this process, several, or a cluster; one file each."""
