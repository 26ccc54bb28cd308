// @ts-check
// Binary search.

/**
 * The count of the first indices that fit, if all that fit come first.
 * @param {number} length
 * @param {(index: number) => boolean} fits
 */
export function partitionPoint(length, fits) {
  let low = 0
  let high = length
  while (low < high) {
    const middle = (low + high) >> 1
    if (fits(middle)) low = middle + 1
    else high = middle
  }
  return low
}
