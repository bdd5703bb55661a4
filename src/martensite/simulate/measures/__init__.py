"""Numbers that sum up a run, such as the stroke or the hottest temperature; one file each."""
