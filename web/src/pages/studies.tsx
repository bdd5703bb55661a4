// Published results, rebuilt: the list of studies, and one of them.

import { useEffect } from "preact/hooks";
import { isStatic } from "../engine/local.ts";
import { isOver } from "../state/jobs.ts";
import { place } from "../state/route.ts";
import { StudyList } from "../studies/list.tsx";
import { follow, work } from "../studies/state.ts";
import { Study } from "../studies/study.tsx";

export function Page() {
  useEffect(() => {
    if (!isStatic() && !isOver(work.job.value)) void work.resume();
    return follow();
  }, []);
  const name = place.value.page === "studies" ? place.value.rest[0] : undefined;
  return name ? <Study key={name} name={name} /> : <StudyList />;
}
