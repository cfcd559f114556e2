import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { get, put, remove, ServiceError, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import { t as ofWhole } from "../i18n/whole";
import { navigate, type PageProps, replaceQuery } from "../router";
import type { Annotation, Bilingual, CharacterWithin, ViewerFacts, Work, WorkCard } from "../types";
import { ErrorMessage, ErrorPage, Loading, useLoaded } from "../ui";
import { Icon } from "../viewer/Icon";
import { type TitledSurface, ViewerPanel } from "../viewer/ViewerPanel";
import { stateFromQuery, stateToQuery, type ViewState } from "../viewer/state";
import type { SheetPoint, Viewer } from "../viewer/types";
import { CharacterBoxes } from "./CharacterBoxes";
import { CharacterCard, CharacterLinks } from "./CharacterFacts";
import { FlatView } from "./FlatView";
import { clearLastList } from "./listState";
import { MuseumFacts } from "./MuseumFacts";
import { NoteForm } from "./NoteForm";
import { hasStrokeOrder, StrokeOrder } from "../strokes/StrokeOrder";
import { ShareWork } from "./ShareWork";
import { WorkFacts } from "./WorkFacts";
import { type Edited, WorkForm } from "./WorkForm";
import { WorkPicker } from "./WorkPicker";
import { WorkText } from "./WorkText";
import "./gallery.css";
import "./work.css";

const WRITE_DELAY_MS = 300;
const UNUSABLE = 422; // status of a picture that no surface can be made of

const workUrl = (id: string): string => `api/works/${encodeURIComponent(id)}`;

/** A work and the viewer's data for it. */
export async function loadWork(id: string, signal: AbortSignal): Promise<{ work: Work; facts: ViewerFacts }> {
  const [work, facts] = await Promise.all([get<Work>(workUrl(id), signal), get<ViewerFacts>(`${workUrl(id)}/viewer`, signal)]);
  return { work, facts };
}

/** A work that no surface can be made of, such as a blank leaf or a painting, is shown as it is, with the reason. `known`: told what is known of it, while its surface may still be computed. */
async function loadShown(id: string, signal: AbortSignal, known: (work: Work) => void): Promise<{ work: Work; facts: ViewerFacts } | { work: Work; reason: Bilingual }> {
  const viewer = get<ViewerFacts>(`${workUrl(id)}/viewer`, signal).catch((error: unknown) => {
    if (error instanceof ServiceError && error.status === UNUSABLE) return error.text;
    throw error;
  });
  const told = get<Work>(workUrl(id), signal).then((one) => {
    if (!signal.aborted) known(one);
    return one;
  });
  const [work, shown] = await Promise.all([told, viewer]);
  return "heights" in shown ? { work, facts: shown } : { work, reason: shown };
}

export default function WorkPage({ params, query }: PageProps) {
  const id = params.id ?? "";
  const [known, setKnown] = useState<Work | null>(null);
  const loaded = useLoaded((signal) => loadShown(id, signal, setKnown), id);
  if (!loaded.fresh && known?.id === id) return <ComingWork work={known} />;
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  if ("reason" in loaded.value) return <FlatWork key={id} {...loaded.value} retry={loaded.retry} />;
  return <WorkView key={id} work={loaded.value.work} facts={loaded.value.facts} query={query} />;
}

/** A work whose surface is still being computed: what it is, and a small picture of it. */
function ComingWork({ work }: { work: Work }) {
  return (
    <article class="work">
      <div class="work-stage viewer">
        <div class="viewer-stages">
          <div class="viewer-stage">
            <div class="viewer-wait"><img src={work.thumb} alt="" /><Loading /></div>
          </div>
        </div>
      </div>
      <aside class="label">
        <WorkFacts work={work} facts={null} />
        <Neighbours work={work} />
      </aside>
    </article>
  );
}

/** A work as its picture alone, and why no lamp shines on it. */
export function FlatWork({ work, reason, retry }: { work: Work; reason: Bilingual; retry: () => void }) {
  const whole = useCharacters(work, null, () => undefined);
  return (
    <article class="work">
      <div class="work-stage">
        <FlatView work={work}>
          {(viewer) => whole.characters.length > 0 && <CharacterBoxes viewer={viewer} {...whole}>{null}</CharacterBoxes>}
        </FlatView>
        <p class="note">{ofWhole("flat")} {localize(reason)}</p>
        {whole.characters.length > 0 && <WorkText {...whole} />}
        {whole.chosen && <CharacterCard one={whole.chosen} />}
      </div>
      <aside class="label">
        <WorkFacts work={work} facts={null} />
        <CharacterLinks work={work} />
        <MuseumFacts record={work.record} />
        <Neighbours work={work} />
        {session.value?.person?.role === "owner" && <OwnerTools work={work} onSaved={retry} />}
      </aside>
    </article>
  );
}

function Neighbours({ work }: { work: Work }) {
  return (
    <nav class="neighbours" aria-label={t("collection")}>
      {work.previous ? <a href={`#/works/${encodeURIComponent(work.previous)}`}><Icon name="previous" />{t("previous")}</a> : <span />}
      {work.next && <a href={`#/works/${encodeURIComponent(work.next)}`}>{t("next")}<Icon name="next" /></a>}
    </nav>
  );
}

function WorkView({ query, ...first }: { work: Work; facts: ViewerFacts; query: URLSearchParams }) {
  const [{ work, facts }, setEdited] = useState(first);
  const [initial] = useState(() => stateFromQuery(query));
  const [viewer, setViewer] = useState<Viewer | null>(null);
  const [notes, setNotes] = useState(work.annotations);
  const [chosen, setChosen] = useState<string | null>(null);
  const [form, setForm] = useState<Partial<Annotation> | null>(null);
  const [picking, setPicking] = useState(false);
  const withId = query.get("with");
  const second = useLoaded((signal) => (withId ? loadWork(withId, signal) : Promise.resolve(null)), withId ?? "");
  const beside: TitledSurface | null = withId && second.value ? { facts: second.value.facts, title: second.value.work.title } : null;
  const surface = useMemo(() => ({ facts, title: work.title }), [facts, work]);
  const owner = session.value?.person?.role === "owner";
  const address = useAddress(initial, viewer, query);
  const whole = useCharacters(work, query.get("at"), (id) => address.put("at", id));

  const choose = (key: string | null) => setChosen(key);
  const saved = (note: Annotation) => {
    setNotes((before) => (before.some((n) => n.id === note.id) ? before.map((n) => (n.id === note.id ? note : n)) : [...before, note]));
    setForm(null);
    setChosen(note.id);
  };
  const deleteNote = async (note: Annotation) => {
    if (!confirm(t("sureRemove"))) return;
    await remove(`${workUrl(work.id)}/annotations/${note.id}`);
    setNotes((before) => before.filter((n) => n.id !== note.id));
  };
  const chooseSecond = (other: WorkCard | null) => {
    setPicking(false);
    address.put("with", other?.id ?? null);
  };
  return (
    <article class="work">
      <div class="work-stage">
        <ViewerPanel surface={surface} initial={initial} beside={beside} onViewer={setViewer} onState={address.note}
          files={{ ...work.files, page: `${workUrl(work.id)}/export.html` }} pins={{ items: notes, chosen, choose }} link={address.link}
          onPair={() => (withId ? chooseSecond(null) : setPicking(true))} onPoint={owner ? (point: SheetPoint) => setForm({ x: point.x, y: point.y }) : undefined}>
          {viewer && whole.characters.length > 0 && <CharacterBoxes viewer={viewer} {...whole}>{whole.chosen && <CharacterCard one={whole.chosen} />}</CharacterBoxes>}
        </ViewerPanel>
        {second.error ? <ErrorMessage error={second.error} retry={second.retry} /> : null}
        {whole.error ? <ErrorMessage error={whole.error} retry={whole.retry} /> : whole.characters.length > 0 && <WorkText {...whole} />}
      </div>
      <aside class="label">
        <WorkFacts work={work} facts={facts} />
        {work.character && <a class="button write" href={`#/studio/${encodeURIComponent(work.id)}`}><Icon name="edit" />{t("write")}</a>}
        <CharacterLinks work={work} />
        <MuseumFacts record={work.record} />
        {hasStrokeOrder(work) && <StrokeOrder key={work.character} character={work.character} />}
        <Notes notes={notes} chosen={chosen} choose={choose} owner={owner} edit={setForm} onDelete={(note) => void deleteNote(note)} />
        <Neighbours work={work} />
        <ShareWork work={work} />
        {owner && <OwnerTools work={work} onSaved={(edited) => setEdited({ work: edited.work, facts: edited.facts ?? facts })} />}
      </aside>
      {form && <NoteForm work={work.id} note={form} onClose={() => setForm(null)} onSaved={saved} />}
      {picking && <WorkPicker title={t("chooseBeside")} not={work.id} onClose={() => setPicking(false)} onChoose={chooseSecond} />}
    </article>
  );
}

const NONE: CharacterWithin[] = [];

/** The characters of a whole work, the one that is pointed at and the one that is chosen, in the picture and in the text alike. */
function useCharacters(work: Work, at: string | null, remember: (id: string | null) => void) {
  const loaded = useLoaded((signal) => (work.characters ? get<CharacterWithin[]>(`${workUrl(work.id)}/characters`, signal) : Promise.resolve(NONE)), work.id);
  const [lit, light] = useState<CharacterWithin | null>(null);
  const [chosenId, setChosenId] = useState(at);
  const [shown, show] = useState(false);
  useEffect(() => setChosenId(at), [at]);
  const characters = loaded.value ?? NONE;
  return {
    characters,
    lit,
    light,
    shown,
    show,
    error: loaded.error,
    retry: loaded.retry,
    chosen: characters.find((one) => one.id === chosenId) ?? null,
    choose: (one: CharacterWithin | null) => {
      setChosenId(one?.id ?? null);
      remember(one?.id ?? null);
    },
  };
}

function OwnerTools({ work, onSaved }: { work: Work; onSaved: (edited: Edited) => void }) {
  const [editing, setEditing] = useState(false);
  const [atHome, setAtHome] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const deleteWork = () => confirm(t("sureRemoveWork")) && remove(workUrl(work.id)).then(() => (clearLastList(), navigate("/gallery")), setError);
  const close = () => setEditing(false);
  return (
    <div class="owner-tools">
      <p>
        <button type="button" class="quiet" onClick={() => setEditing(true)}>{t("editWork")}</button>
        <button type="button" class="quiet" onClick={() => put("api/home", { work: work.id }).then(() => setAtHome(true), setError)}>{t("showAtHome")}</button>
        <button type="button" class="quiet" onClick={deleteWork}>{t("removeWork")}</button>
      </p>
      {atHome && <p class="note" role="status">{t("isAtHome")}</p>}
      {error ? <ErrorMessage error={error} /> : null}
      {editing && <WorkForm work={work} onClose={close} onSaved={(edited) => (onSaved(edited), close())} />}
    </div>
  );
}

/** What the address holds besides the view: the work that stands beside, and the character that is chosen. */
type Extra = { with: string | null; at: string | null };
const extraOf = (query: URLSearchParams): Extra => ({ with: query.get("with"), at: query.get("at") });

/** Keeps the view in the address, written when the view has been at rest; an address entered by hand changes the view. */
function useAddress(initial: ViewState, viewer: Viewer | null, query: URLSearchParams) {
  const now = useRef(initial);
  const timer = useRef(0);
  const extra = useRef(extraOf(query));
  const lastWritten = useRef(query.toString());
  const fullQuery = () => {
    const all = stateToQuery(now.current);
    for (const [name, value] of Object.entries(extra.current)) if (value) all.set(name, value);
    return all;
  };
  const write = () => {
    const all = fullQuery();
    lastWritten.current = all.toString();
    replaceQuery(all);
  };
  useEffect(() => {
    if (query.toString() === lastWritten.current) return;
    lastWritten.current = query.toString();
    extra.current = extraOf(query);
    viewer?.set(stateFromQuery(query));
  }, [query.toString()]);
  useEffect(() => () => clearTimeout(timer.current), []);
  return {
    note(state: ViewState) {
      now.current = state;
      clearTimeout(timer.current);
      timer.current = window.setTimeout(write, WRITE_DELAY_MS);
    },
    put(name: keyof Extra, value: string | null) {
      extra.current = { ...extra.current, [name]: value };
      write();
    },
    link: () => `${location.href.split("#")[0]}${location.hash.split("?")[0]}?${fullQuery().toString().replaceAll("%2C", ",")}`,
  };
}

type NotesProps = {
  notes: Annotation[];
  chosen: string | null;
  owner: boolean;
  choose: (id: string | null) => void;
  edit: (note: Annotation) => void;
  onDelete: (note: Annotation) => void;
};

function Notes({ notes, chosen, owner, choose, edit, onDelete }: NotesProps) {
  if (!notes.length) return null;
  return (
    <section class="notes">
      <h2>{t("notes")}</h2>
      <ol>
        {notes.map((note) => (
          <li key={note.id} class={note.id === chosen ? "on" : ""}>
            <button type="button" class="quiet note-head" aria-expanded={note.id === chosen} onClick={() => choose(note.id === chosen ? null : note.id)}>{localize(note.title)}</button>
            {note.id === chosen && <p>{localize(note.text)}</p>}
            {owner && note.id === chosen && (
              <p class="note-edit">
                <button type="button" class="quiet" onClick={() => edit(note)}>{t("edit")}</button>
                <button type="button" class="quiet" onClick={() => onDelete(note)}>{t("removeNote")}</button>
              </p>
            )}
          </li>
        ))}
      </ol>
    </section>
  );
}
