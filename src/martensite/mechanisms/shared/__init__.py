"""What mechanisms are made with; no mechanism is registered here."""
