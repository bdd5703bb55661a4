"""Forms of the bench: a control for each declared parameter, option and kind of a scenario.

Forms follow from declarations, material and document, without knowledge of parts by name. New kinds start with the
typical values of their declarations.
"""
