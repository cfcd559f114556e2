// The classes that somebody teaches or learns in.

import { useState } from "preact/hooks";
import { get, post, session } from "../api";
import { go, type PageProps } from "../router";
import { Field, PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { NeedLogin } from "./NeedLogin";
import { w } from "./say";

export type ClassCard = { id: string; name: string; pupils: number; tasks: number };

export default function Classes(_: PageProps) {
  return (
    <NeedLogin why={w("classesNeed")}>
      <Own />
    </NeedLogin>
  );
}

function Own() {
  const found = useLoaded((signal) => get<ClassCard[]>("/api/classes", signal), "classes");
  const teaches = session.value?.person?.role !== "pupil";
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  return (
    <div class="classes">
      <h1>{w("classesTitle")}</h1>
      {!found.value.length && <p class="note">{w(teaches ? "noClassesTeacher" : "noClassesPupil")}</p>}
      <ul class="class-list">
        {found.value.map((one) => (
          <li key={one.id}>
            <a class="panel class-card" href={`#/classes/${one.id}`}>
              <b>{one.name}</b>
              <small class="note">{w("classCount", { pupils: one.pupils, tasks: one.tasks })}</small>
            </a>
          </li>
        ))}
      </ul>
      {teaches && (
        <p>
          <a class="button quiet" href="/api/marks.zip" download="marks.zip">
            {w("allMarksZip")}
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
    post<{ id: string }>("/api/classes", { name: name.trim() }).then((made) => go(`/classes/${made.id}`), setError);
  };
  return (
    <form class="panel new-class" onSubmit={make}>
      <h2>{w("newClass")}</h2>
      <Field label={w("className")}>
        <input required maxLength={120} value={name} onInput={(event) => setName(event.currentTarget.value)} />
      </Field>
      <button type="submit">{w("makeClass")}</button>
      {error !== null && <Trouble error={error} />}
    </form>
  );
}
