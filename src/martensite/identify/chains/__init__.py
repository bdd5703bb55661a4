"""Dynamic models from records: blocks in series, estimated, validated, used."""
