// A board: its firmware, a run that is watched while it goes, its log.

import { useEffect } from "preact/hooks";
import { isOver } from "../state/jobs.ts";
import { Curves } from "../board/curves.tsx";
import { Form } from "../board/form.tsx";
import { Live } from "../board/live.tsx";
import { columns, known, readBoards, refused, work } from "../board/state.ts";
import { Empty } from "../ui/empty.tsx";
import { Message } from "../ui/message.tsx";

export function Page() {
  useEffect(() => {
    void readBoards();
    if (!isOver(work.job.value)) void work.resume();
  }, []);
  const there = known.value;
  return (
    <div class="board stack">
      <h1>Board</h1>
      {refused.value && <Message kind="error">{refused.value}</Message>}
      {there && (
        <div class="board-page">
          <Form />
          <div class="stack board-results">
            <Live />
            {!work.job.value && !columns.value["time"] && <Empty picture="hold">Curves and link statistics appear here while the board runs.</Empty>}
            <Curves />
          </div>
        </div>
      )}
    </div>
  );
}
