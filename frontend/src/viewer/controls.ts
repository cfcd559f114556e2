// Turns pointer, wheel, pinch and key events into calls of a few handlers, which the caller provides.

export type Action = "light" | "orbit" | "pan" | "line" | "point";
type InputHandlers = {
  /** What dragging with one finger or the main button does at present. */
  action(): Action;
  /** The lamp is moved to (x, y) over the picture, in CSS pixels from its top left. */
  light(x: number, y: number): void;
  orbit(dx: number, dy: number): void;
  pan(dx: number, dy: number): void;
  /** Factor < 1 is nearer; towards (x, y). */
  zoom(factor: number, x: number, y: number): void;
  line(phase: "start" | "move" | "end", x: number, y: number): void;
  point(x: number, y: number): void;
  hover(point: { x: number; y: number } | null): void;
  key(event: KeyboardEvent): boolean;
};

const MAX_TAP_DISTANCE = 5;

/** Listens on `host`; the function returned stops listening. */
export function listenForInput(host: HTMLElement, handlers: InputHandlers): () => void {
  const controller = new AbortController();
  const fingers = new Map<number, { x: number; y: number }>();
  let doing: Action | "pinch" | null = null;
  let start = { x: 0, y: 0 };
  const at = (event: { clientX: number; clientY: number }) => {
    const box = host.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const on = <K extends keyof HTMLElementEventMap>(name: K, act: (event: HTMLElementEventMap[K]) => void, passive = true) =>
    host.addEventListener(name, act as EventListener, { signal: controller.signal, passive });

  on("pointerdown", (event) => {
    const point = at(event);
    fingers.set(event.pointerId, point);
    host.setPointerCapture?.(event.pointerId);
    if (fingers.size === 2) {
      if (doing === "line") handlers.line("end", start.x, start.y);
      doing = "pinch";
      return;
    }
    if (fingers.size > 2) return;
    start = point;
    doing = event.button === 2 ? "orbit" : event.button === 1 || event.shiftKey ? "pan" : handlers.action();
    if (doing === "light") handlers.light(point.x, point.y);
    if (doing === "line") handlers.line("start", point.x, point.y);
  });
  on("pointermove", (event) => {
    const point = at(event);
    const before = fingers.get(event.pointerId);
    handlers.hover(point);
    if (!before || !doing) return;
    if (doing === "pinch") pinch(fingers, event.pointerId, point, handlers);
    else if (doing === "light") handlers.light(point.x, point.y);
    else if (doing === "orbit") handlers.orbit(point.x - before.x, point.y - before.y);
    else if (doing === "pan") handlers.pan(point.x - before.x, point.y - before.y);
    else if (doing === "line") handlers.line("move", point.x, point.y);
    fingers.set(event.pointerId, point);
  });
  const lift = (event: PointerEvent) => {
    const point = at(event);
    if (doing === "line") handlers.line("end", point.x, point.y);
    if (doing === "point" && event.type === "pointerup" && Math.hypot(point.x - start.x, point.y - start.y) < MAX_TAP_DISTANCE) {
      handlers.point(point.x, point.y);
    }
    fingers.delete(event.pointerId);
    doing = null;
    if (event.pointerType !== "mouse") handlers.hover(null);
  };
  on("pointerup", lift);
  on("pointercancel", lift);
  on("pointerleave", () => handlers.hover(null));
  on(
    "wheel",
    (event) => {
      event.preventDefault();
      const point = at(event);
      const lines = event.deltaMode === 1 ? 16 : 1;
      handlers.zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY * lines)) * 0.0018), point.x, point.y);
    },
    false,
  );
  on("contextmenu", (event) => event.preventDefault(), false);
  on("keydown", (event) => handlers.key(event) && event.preventDefault(), false);
  return () => controller.abort();
}

function pinch(fingers: Map<number, { x: number; y: number }>, id: number, point: { x: number; y: number }, handlers: InputHandlers): void {
  const [other] = [...fingers].filter(([key]) => key !== id).map(([, value]) => value);
  const before = fingers.get(id);
  if (!other || !before) return;
  const middle = { x: (point.x + other.x) / 2, y: (point.y + other.y) / 2 };
  const [was, is] = [Math.hypot(before.x - other.x, before.y - other.y), Math.hypot(point.x - other.x, point.y - other.y)];
  handlers.pan((point.x - before.x) / 2, (point.y - before.y) / 2);
  if (was > 1 && is > 1) handlers.zoom(was / is, middle.x, middle.y);
}
