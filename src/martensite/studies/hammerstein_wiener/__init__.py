"""Study `hammerstein-wiener`: a wire identified in two stages, and a PID controller tuned on it."""
