"""The element, or its material, as a part of other programs: length or strain in, force or stress out."""
