// The classes of a teacher or of a pupil.

import { useState } from "preact/hooks";
import { get, post, session } from "../api";
import { t } from "../i18n/studio";
import { navigate, type PageProps } from "../router";
import { ErrorMessage, ErrorPage, Field, Loading, useLoaded } from "../ui";
import { RequireLogin } from "../account/RequireLogin";

type ClassCard = { id: string; name: string; pupils: number; tasks: number };

export default function ClassesPage(_: PageProps) {
  return (
    <RequireLogin reason={t("classesNeed")}>
      <ClassList />
    </RequireLogin>
  );
}

function ClassList() {
  const loaded = useLoaded((signal) => get<ClassCard[]>("api/classes", signal), "classes");
  const teaches = session.value?.person?.role !== "pupil";
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  return (
    <div class="classes">
      <h1>{t("classesTitle")}</h1>
      {!loaded.value.length && <p class="note">{t(teaches ? "noClassesTeacher" : "noClassesPupil")}</p>}
      <ul class="class-list">
        {loaded.value.map((one) => (
          <li key={one.id}>
            <a class="panel class-card" href={`#/classes/${one.id}`}>
              <b>{one.name}</b>
              <small class="note">{t("classCount", { pupils: one.pupils, tasks: one.tasks })}</small>
            </a>
          </li>
        ))}
      </ul>
      {teaches && (
        <p>
          <a class="button quiet" href="api/marks.zip" download="marks.zip">
            {t("allMarksZip")}
          </a>
        </p>
      )}
      {teaches && <NewClass />}
    </div>
  );
}

function NewClass() {
  const [name, setName] = useState("");
  const [error, setError] = useState<unknown>(null);
  const make = (event: Event) => {
    event.preventDefault();
    post<{ id: string }>("api/classes", { name: name.trim() }).then((made) => navigate(`/classes/${made.id}`), setError);
  };
  return (
    <form class="panel new-class" onSubmit={make}>
      <h2>{t("newClass")}</h2>
      <Field label={t("className")}>
        <input required maxLength={120} value={name} onInput={(event) => setName(event.currentTarget.value)} />
      </Field>
      <button type="submit">{t("makeClass")}</button>
      {error !== null && <ErrorMessage error={error} />}
    </form>
  );
}
