// What was read in photographs of sheets: the cells of one with their marks, or the table of a class.

import { RequireLogin } from "../account/RequireLogin";
import { get, query, session } from "../api";
import { formatDateTime, localize } from "../i18n";
import { t } from "../i18n/sheets";
import type { PageProps } from "../router";
import { ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { lowestOf, rowsOf, sentenceOf, type SheetCell, type SheetPhoto, type SheetUpload } from "./upload";
import "../studio/studio.css";
import "./sheets.css";

export default function MarksPage({ params }: PageProps) {
  return (
    <RequireLogin reason={t("photoNeeds")}>
      <MarksView id={params["id"] ?? ""} />
    </RequireLogin>
  );
}

function MarksView({ id }: { id: string }) {
  const loaded = useLoaded((signal) => get<SheetUpload>(`api/sheets/${id}`, signal), id);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const { school_class, photos, created } = loaded.value;
  const back = query({ class: school_class?.id });
  return (
    <div class="marks-page">
      <p class="note">
        <a href={`#/sheets${back}`}>← {t(school_class ? "table" : "photoTitle")}</a>
      </p>
      <header class="page-head">
        <h1>{school_class ? `${school_class.name} · ${t("table")}` : (charactersOf(photos) || t("photoTitle"))}</h1>
        <p class="note">{formatDateTime(created)}</p>
      </header>
      {loaded.value.table ? <ClassTable upload={loaded.value} /> : photos.map((photo, k) => <SheetOfPhoto key={k} photo={photo} />)}
      <p class="row">
        <a class="button quiet" href={`#/sheets${back}`}>{t("anotherSheet")}</a>
      </p>
    </div>
  );
}

const charactersOf = (photos: SheetPhoto[]): string => [...new Set(photos.flatMap((photo) => photo.cells.map((cell) => cell.character)))].join("");

/** One photograph: what it is of, and its cells as they stand on the sheet. */
function SheetOfPhoto({ photo }: { photo: SheetPhoto }) {
  return (
    <section class="read-sheet">
      <p class="note">
        <Facts
          items={[
            photo.sheet && t("sheetNumber", { sheet: photo.sheet, number: photo.number ?? 1, count: photo.count ?? 1 }),
            t("countOf", { cells: photo.cells.length }), photo.mean !== null && t("meanOf", { mean: photo.mean.toFixed(0) }),
            photo.empty > 0 && t("emptyCells", { n: photo.empty }),
          ]}
        />
      </p>
      <Whose photo={photo} />
      {photo.refused ? (
        <p class="trouble">{localize(photo.refused)}</p>
      ) : photo.cells.length ? (
        rowsOf(photo.cells).map((row) => (
          <ul key={row[0]!.row} class="sheet-row">
            {row.map((cell) => (
              <li key={cell.column}><CellCard cell={cell} /></li>
            ))}
          </ul>
        ))
      ) : (
        <p class="note">{t("allEmpty")}</p>
      )}
    </section>
  );
}

/** In whose practice a sheet was kept, where that is not plain. */
function Whose({ photo }: { photo: SheetPhoto }) {
  const { person, pupil, is_of_another, refused } = photo;
  if (refused) return null;
  if (person && is_of_another) return <p class="visitor">{t("ofAnother", { pupil, person: person.name })}</p>;
  if (person) return person.id === session.value?.person?.id ? null : <p class="note">{t("keptBy", { person: person.name })}</p>;
  return <p class="note">{pupil ? t("nobodys", { pupil }) : t("unnamed")}</p>;
}

function CellCard({ cell }: { cell: SheetCell }) {
  const sentence = sentenceOf(cell);
  const inside = (
    <>
      {cell.picture && <img src={cell.picture} alt={t("cellAlt", { character: cell.character })} width="200" height="200" loading="lazy" />}
      <span class="sheet-cell-head">
        <b lang="zh-Hant">{cell.character}</b>
        <span class="attempt-score">{cell.score === null ? t("noMark") : <><strong>{cell.score.toFixed(0)}</strong> {localize(cell.level_text)}</>}</span>
      </span>
      {sentence && <span class={cell.refused ? "sheet-told refusing" : "sheet-told"}>{localize(sentence)}</span>}
    </>
  );
  return cell.attempt ? <a class="sheet-cell" href={`#/attempts/${cell.attempt}`}>{inside}</a> : <div class="sheet-cell">{inside}</div>;
}

function ClassTable({ upload }: { upload: SheetUpload }) {
  return (
    <>
      <p class="row">
        <a class="button" href={upload.archive!} download="marks.zip">{t("allFiles")}</a>
        <a class="button quiet" href={upload.table!} download="marks.csv">{t("csv")}</a>
        <a class="button quiet" href={upload.teacher!} download="teacher.pdf">{t("teacherPdf")}</a>
      </p>
      <div class="scroll" tabIndex={0} role="region" aria-label={t("table")}>
        <table>
          <thead>
            <tr>
              <th scope="col">{t("photo")}</th>
              <th scope="col">{t("pupilName")}</th>
              <th scope="col" class="number">{t("characters")}</th>
              <th scope="col" class="number">{t("mean")}</th>
              <th scope="col">{t("lowest")}</th>
              <th scope="col">{t("account")}</th>
            </tr>
          </thead>
          <tbody>{upload.photos.map((photo, k) => <PhotoRow key={k} photo={photo} />)}</tbody>
        </table>
      </div>
      {upload.photos.filter((photo) => photo.cells.length).map((photo, k) => (
        <details key={k} class="panel sheet-details">
          <summary>{photo.pupil || photo.photo}</summary>
          <SheetOfPhoto photo={photo} />
        </details>
      ))}
    </>
  );
}

function PhotoRow({ photo }: { photo: SheetPhoto }) {
  const lowest = lowestOf(photo.cells);
  return (
    <tr>
      <th scope="row">{photo.photo}</th>
      {photo.refused ? (
        <td colSpan={5} class="sheet-unread">{localize(photo.refused)}</td>
      ) : (
        <>
          <td>{photo.pupil || "–"}</td>
          <td class="number">{photo.cells.length}</td>
          <td class="number">{photo.mean?.toFixed(0) ?? "–"}</td>
          <td>{lowest ? <><span lang="zh-Hant">{lowest.character}</span> {lowest.score!.toFixed(0)}</> : "–"}</td>
          <td>{photo.person ? <a href={`#/practice?person=${photo.person.id}`}>{photo.person.name}</a> : "–"}</td>
        </>
      )}
    </tr>
  );
}
