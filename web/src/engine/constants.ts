// Written by write_types.py from declarations in Python; do not edit.

export const LOCAL = { 2: 0.24, 4: 0.96 } as const;
export const ERROR_SAFETY = 1.25;
export const FLOOR = 0.5;
export const FINER = 8;
export const MOST_PASSES = 5;
export const FEW = 201;
export const LEAST_ACCURACY = 1e-12;
export const SHORTEST = 1e-12;
export const FINEST = 0.0001;
export const ROUGHNESS = 3e-11;
export const ROUNDING = 1e-09;
export const DRIFT = 0.05;
export const CYCLE = 0.5;
export const RETURNED = 0.01;
export const LOADED_ALIKE = 0.2;
export const WINDOW = 0.25;
export const CAPTURED = 1.5;
