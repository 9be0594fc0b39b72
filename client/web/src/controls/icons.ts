// Icons as inline SVG, 24 by 24.
const PATHS = {
  play: '<path d="M7 4.5v15l12.5-7.5z"/>',
  pause: '<path d="M6.5 5h4v14h-4zM13.500 5h4v14h-4z"/>',
  back: '<path d="M18 5v14l-9.500-7zM5.500 5h2.200v14H5.500z"/>',
  forward: '<path d="M6 5v14l9.500-7zM16.300 5h2.200v14h-2.200z"/>',
  loop: '<path d="M18.500 9A7.200 7.200 0 1 0 19 13.500" fill="none" stroke="currentColor" stroke-width="2"/><path d="M20.500 4v6.500H14z"/>',
  help: '<path d="M8.500 9a3.500 3.500 0 1 1 5.200 3.050c-1.100.65-1.700 1.200-1.700 2.700" fill="none" stroke="currentColor" stroke-width="2"/><circle cx="12" cy="18.500" r="1.400"/>',
  drawing: '<path d="M3.500 6.500h17M3.500 12h17M3.500 17.500h17" stroke="currentColor" stroke-width="1.800"/><circle cx="8.500" cy="6.500" r="2.500"/><circle cx="15.500" cy="12" r="2.500"/><circle cx="8.500" cy="17.500" r="2.500"/>',
  statistics: '<path d="M4 13h4v7H4zM10 8h4v12h-4zM16 4h4v16h-4z"/>',
  fullscreen: '<path d="M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5" fill="none" stroke="currentColor" stroke-width="2"/>',
  camera: '<path d="M4 7.500h4l1.500-2.500h5L16 7.500h4v11H4z" fill="none" stroke="currentColor" stroke-width="1.800"/><circle cx="12" cy="12.800" r="3.200" fill="none" stroke="currentColor" stroke-width="1.800"/>',
  sound: '<path d="M3.500 9h4l5-4.500v15L7.500 15h-4z"/><path d="M15.500 8.500a5 5 0 0 1 0 7M18 6a8.500 8.500 0 0 1 0 12" fill="none" stroke="currentColor" stroke-width="1.800"/>',
  muted: '<path d="M3.500 9h4l5-4.500v15L7.500 15h-4z"/><path d="M15.500 9.500l5 5M20.500 9.500l-5 5" stroke="currentColor" stroke-width="1.800"/>',
  link: '<path d="M10 14a4 4 0 0 0 5.700 0l3-3A4 4 0 0 0 13 5.300l-1.200 1.200M14 10a4 4 0 0 0-5.700 0l-3 3a4 4 0 0 0 5.700 5.700l1.200-1.200" fill="none" stroke="currentColor" stroke-width="2"/>',
} as const;
export type Icon = keyof typeof PATHS;

export function icon(name: Icon): string {
  return `<svg viewBox="0 0 24 24" fill="currentColor" aria-hidden="true">${PATHS[name]}</svg>`;
}
