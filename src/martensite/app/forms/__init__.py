"""Forms of the bench: a control for every declared number, option and kind of a scenario.

Nothing here knows a part by name: what a form shows is taken from the declarations, from the
material and from the document. Kinds that are chosen anew begin with the typical values of their
declarations.
"""
