// Pointer, wheel, pinch and keys become a few verbs. What they do is decided elsewhere.

export type Action = "light" | "orbit" | "pan" | "line" | "point";
export type Verbs = {
  /** What dragging with one finger or the main button does now. */
  action(): Action;
  /** The lamp stands over (x, y) of the picture, in CSS pixels from its top left. */
  light(x: number, y: number): void;
  orbit(dx: number, dy: number): void;
  pan(dx: number, dy: number): void;
  /** Factor under 1 is nearer; towards (x, y). */
  zoom(factor: number, x: number, y: number): void;
  line(phase: "start" | "move" | "end", x: number, y: number): void;
  point(x: number, y: number): void;
  hover(place: { x: number; y: number } | null): void;
  key(event: KeyboardEvent): boolean;
};

const TAP = 5;

/** Listens on `host`; the answer stops listening. */
export function listen(host: HTMLElement, verbs: Verbs): () => void {
  const stop = new AbortController();
  const fingers = new Map<number, { x: number; y: number }>();
  let doing: Action | "pinch" | null = null;
  let start = { x: 0, y: 0 };
  const at = (event: { clientX: number; clientY: number }) => {
    const box = host.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const on = <K extends keyof HTMLElementEventMap>(name: K, act: (event: HTMLElementEventMap[K]) => void, passive = true) =>
    host.addEventListener(name, act as EventListener, { signal: stop.signal, passive });

  on("pointerdown", (event) => {
    const place = at(event);
    fingers.set(event.pointerId, place);
    host.setPointerCapture?.(event.pointerId);
    if (fingers.size === 2) {
      if (doing === "line") verbs.line("end", start.x, start.y);
      doing = "pinch";
      return;
    }
    if (fingers.size > 2) return;
    start = place;
    doing = event.button === 2 ? "orbit" : event.button === 1 || event.shiftKey ? "pan" : verbs.action();
    if (doing === "light") verbs.light(place.x, place.y);
    if (doing === "line") verbs.line("start", place.x, place.y);
  });
  on("pointermove", (event) => {
    const place = at(event);
    const before = fingers.get(event.pointerId);
    verbs.hover(place);
    if (!before || !doing) return;
    if (doing === "pinch") pinch(fingers, event.pointerId, place, verbs);
    else if (doing === "light") verbs.light(place.x, place.y);
    else if (doing === "orbit") verbs.orbit(place.x - before.x, place.y - before.y);
    else if (doing === "pan") verbs.pan(place.x - before.x, place.y - before.y);
    else if (doing === "line") verbs.line("move", place.x, place.y);
    fingers.set(event.pointerId, place);
  });
  const lift = (event: PointerEvent) => {
    const place = at(event);
    if (doing === "line") verbs.line("end", place.x, place.y);
    if (doing === "point" && event.type === "pointerup" && Math.hypot(place.x - start.x, place.y - start.y) < TAP) {
      verbs.point(place.x, place.y);
    }
    fingers.delete(event.pointerId);
    doing = null;
    if (event.pointerType !== "mouse") verbs.hover(null);
  };
  on("pointerup", lift);
  on("pointercancel", lift);
  on("pointerleave", () => verbs.hover(null));
  on(
    "wheel",
    (event) => {
      event.preventDefault();
      const place = at(event);
      const lines = event.deltaMode === 1 ? 16 : 1;
      verbs.zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY * lines)) * 0.0018), place.x, place.y);
    },
    false,
  );
  on("contextmenu", (event) => event.preventDefault(), false);
  on("keydown", (event) => verbs.key(event) && event.preventDefault(), false);
  return () => stop.abort();
}

function pinch(fingers: Map<number, { x: number; y: number }>, id: number, place: { x: number; y: number }, verbs: Verbs): void {
  const [other] = [...fingers].filter(([key]) => key !== id).map(([, value]) => value);
  const before = fingers.get(id);
  if (!other || !before) return;
  const middle = { x: (place.x + other.x) / 2, y: (place.y + other.y) / 2 };
  const [was, is] = [Math.hypot(before.x - other.x, before.y - other.y), Math.hypot(place.x - other.x, place.y - other.y)];
  verbs.pan((place.x - before.x) / 2, (place.y - before.y) / 2);
  if (was > 1 && is > 1) verbs.zoom(was / is, middle.x, middle.y);
}
