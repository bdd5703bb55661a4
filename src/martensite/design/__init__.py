"""Questions to a model: size and tune; design and sweep, sweep and optimise."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
