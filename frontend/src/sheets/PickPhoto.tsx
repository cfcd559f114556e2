// A button that chooses pictures, from the camera or from files.

export const PHOTO_TYPES = "image/png,image/jpeg,image/webp,image/heic,image/heif,image/avif";

type Props = { label: string; camera?: boolean; many?: boolean; types?: string; onFiles: (files: File[]) => void };

export function PickPhoto({ label, camera, many, types = PHOTO_TYPES, onFiles }: Props) {
  const pick = (event: Event & { currentTarget: HTMLInputElement }) => {
    const files = [...(event.currentTarget.files ?? [])];
    event.currentTarget.value = ""; // so that the same file can be chosen again
    onFiles(files);
  };
  return (
    <label class={`button quiet pick${camera ? " camera" : ""}`}>
      {label}
      <input type="file" class="visually-hidden" accept={types} multiple={many ?? false} {...(camera ? { capture: "environment" } : {})} onChange={pick} />
    </label>
  );
}
