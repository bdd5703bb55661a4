// Viridis, which is perceptually even and can be told apart without colour vision, by ten of its stops.

const STOPS = ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
const RGB = STOPS.map((stop) => [1, 3, 5].map((k) => parseInt(stop.slice(k, k + 2), 16)));
const STEPS = 256;

const between = (share: number): string => {
  const place = share * (RGB.length - 1);
  const k = Math.min(Math.floor(place), RGB.length - 2);
  const mixed = [0, 1, 2].map((c) => {
    const [a, b] = [RGB[k]?.[c] ?? 0, RGB[k + 1]?.[c] ?? 0];
    return Math.round(a + (place - k) * (b - a));
  });
  return `rgb(${mixed.join(" ")})`;
};
const TABLE = Array.from({ length: STEPS }, (_, k) => between(k / (STEPS - 1)));

/** Colour of a share from 0 to 1. */
export const viridis = (share: number): string => TABLE[Math.round(Math.min(Math.max(share, 0), 1) * (STEPS - 1))] ?? "";

