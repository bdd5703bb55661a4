"""Search and inference for fits, designs and identified models."""
