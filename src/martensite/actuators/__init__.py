"""What moves: elements, mechanisms, and the system they make up."""
