// @ts-check
// The elements of index.html by their ids, and those that are made. All elements with ids exist, so a missing one is a
// mistake of ours.

/** @param {string} id */
export function find(id) {
  return findA(id, HTMLElement)
}

/** @template {HTMLElement} T @param {string} id @param {{ new (): T }} kind @returns {T} */
export function findA(id, kind) {
  const element = document.getElementById(id)
  if (!(element instanceof kind)) throw new Error(`the page has no ${kind.name} called ${id}`)
  return element
}

/**
 * Makes an element with these properties and children.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Partial<HTMLElementTagNameMap[Tag]>} properties
 * @param {(Node | string)[]} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties)
  made.append(...children)
  return made
}

/** Makes a span. @param {string} className @param {string} textContent */
export function span(className, textContent = "") {
  return element("span", { className, textContent })
}

/**
 * Makes a button that calls a function when it is pressed.
 * @param {Partial<HTMLButtonElement>} properties
 * @param {(event: MouseEvent) => void} press
 */
export function button(properties, press) {
  const made = element("button", { type: "button", ...properties })
  made.addEventListener("click", press)
  return made
}

/**
 * Makes an element that is about a robot, and in its color.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {{ name: string, color: string }} robot
 * @param {(Node | string)[]} children
 */
export function robotElement(tag, { name, color }, ...children) {
  const made = element(tag, {}, ...children)
  /** @type {HTMLElement} */
  const { dataset, style } = made
  dataset.robot = name
  style.setProperty("--robot", color)
  return made
}

/**
 * Makes an element of an SVG.
 * @template {keyof SVGElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string>} attributes
 */
export function svgElement(tag, attributes = {}) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag)
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value)
  return made
}

/**
 * Adds paths to an SVG, the last one in front. Returns a function that draws them, by their classes.
 * @template {string} Class
 * @param {SVGElement} parent
 * @param {readonly Class[]} classes
 * @returns {(drawn: Record<Class, string>) => void}
 */
export function svgPaths(parent, classes) {
  const paths = classes.map((name) => svgElement("path", { class: name }))
  parent.append(...paths)
  return (drawn) => classes.forEach((name, index) => paths[index].setAttribute("d", drawn[name]))
}

/** Puts a text into an element, unless it is there already: browsers lay the page out again for the same text, too. @param {Element} element @param {string} text */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text
}

/** The address of an SVG, for an image: the page may load no others. @param {string} svg */
export function svgAddress(svg) {
  return `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`
}

/** Saves a file. @param {string} name @param {Blob} blob */
export function download(name, blob) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name })
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000)
}

/**
 * Has a parent hold a child for each name, in this order. A child that is there already stays, and is not made again:
 * somebody may be pressing it.
 * @param {HTMLElement} parent
 * @param {string[]} names
 * @param {(name: string) => HTMLElement} make
 */
export function syncChildren(parent, names, make) {
  const children = () => /** @type {HTMLElement[]} */ ([...parent.children])
  const before = new Map(children().map((child) => [child.dataset.name, child]))
  for (const child of children()) if (!names.includes(child.dataset.name ?? "")) child.remove()
  names.forEach((name, i) => {
    const at = children()[i]
    if (at?.dataset.name === name) return
    const child = before.get(name) ?? make(name)
    child.dataset.name = name
    parent.insertBefore(child, at ?? null)
  })
}
