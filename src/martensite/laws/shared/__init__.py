"""What several laws share; no law is registered here."""
