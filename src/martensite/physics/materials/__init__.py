"""Materials: parameters with sources under canonical names, one TOML file per source."""
