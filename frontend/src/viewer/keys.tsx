import { words } from "../i18n";
import { viewer as table } from "../i18n/viewer";
import { Dialog } from "../ui";

const t = words(table);
const KEYS: [string, Parameters<typeof t>[0]][] = [
  ["← → ↑ ↓", "keyLight"],
  ["⇧ ← → ↑ ↓", "keyOrbit"],
  ["+ −", "keyZoom"],
  ["0", "keyHome"],
  ["1 – 5", "keyModes"],
  ["L M C R", "keyTools"],
  ["F", "keyFull"],
  ["?", "keyHelp"],
];
const HANDS: Parameters<typeof t>[0][] = ["handLight", "handMove", "handPinch", "handOther"];

export function KeysHelp({ onClose }: { onClose: () => void }) {
  return (
    <Dialog title={t("help")} onClose={onClose}>
      <ul class="hands">
        {HANDS.map((name) => (
          <li key={name}>{t(name)}</li>
        ))}
      </ul>
      <table class="keys">
        <tbody>
          {KEYS.map(([key, name]) => (
            <tr key={key}>
              <th scope="row"><kbd>{key}</kbd></th>
              <td>{t(name)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </Dialog>
  );
}
