/** Where somebody logs in, to come back to the present page. */
export const loginLink = (): string => `#/login?back=${encodeURIComponent(location.hash.replace(/^#/, "") || "/")}`;

/** Where to go after a login: a path of these pages, never another place. */
export const wayBack = (back: string | null): string => (back && /^\/(?!\/)/.test(back) ? back : "/");
