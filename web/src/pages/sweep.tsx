// Sweeps: many variants of a scenario, their picture while they come, and those that are kept.

import { useEffect } from "preact/hooks";
import { beginForm, followForm } from "../sweep/asking.ts";
import { Export } from "../sweep/export.tsx";
import { follow, running } from "../sweep/following.ts";
import { Form } from "../sweep/form.tsx";
import { List } from "../sweep/list.tsx";
import { Live } from "../sweep/live.tsx";
import { Pictures } from "../sweep/picture.tsx";
import { key, list, refused, stored, work } from "../sweep/shown.ts";
import { Empty } from "../ui/empty.tsx";
import { Message } from "../ui/message.tsx";

function Title() {
  const now = stored.value;
  if (!key.value || !now) return <h1>Sweep</h1>;
  return (
    <div class="sweep-title">
      <h1>{now.title}</h1>
      <p class="soft small">
        {now.over.join("; ")} ({now.sample})
      </p>
    </div>
  );
}

export function Page() {
  useEffect(() => {
    const leave = [followForm(), follow()];
    void beginForm();
    void work.resume();
    void list();
    return () => leave.forEach((end) => end());
  }, []);
  return (
    <div class="sweep">
      <Form />
      <div class="stack sweep-results">
        <Title />
        {refused.value && <Message kind="error">{refused.value}</Message>}
        <Live />
        {!key.value && !running.value && <Empty picture="sweep">Vary any parameter of a scenario: one gives a curve, two a map, more a scatter plot. Results appear during the runs.</Empty>}
        <Pictures key={key.value} />
        <Export key={`export ${key.value}`} />
        <List />
      </div>
    </div>
  );
}
