"""Questions to a model: size, design, tune, sweep."""
