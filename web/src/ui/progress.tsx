// How far long work is, with a button that ends it.

export interface ProgressProps {
  /** 0 to 1; null if it is not known. */
  share: number | null;
  label: string;
  onCancel?: () => void;
}

export function Progress({ share, label, onCancel }: ProgressProps) {
  return (
    <div class="progress">
      <progress max={1} aria-label={label} {...(share === null ? {} : { value: share })} />
      <span role="status">{label}</span>
      {onCancel && (
        <button type="button" onClick={onCancel}>
          Cancel
        </button>
      )}
    </div>
  );
}
