"""What the calls of the page Identify share: files looked at, columns mapped, fits begun and told."""
