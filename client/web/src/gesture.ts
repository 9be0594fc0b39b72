// Browsers play no sound before the user has done something on the page.

/** Browsers that do not tell are asked again and again. */
export const hasActed = () => (navigator as { userActivation?: { hasBeenActive: boolean } }).userActivation?.hasBeenActive !== false;
