// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the results for several pictures.

/** Returns the name of a result: the name of the picture, with another extension and, if it is taken, a number. */
function nameFor(picture, extension, taken) {
  const stem = picture.name.replace(/\.[^.]*$/, "");
  for (let number = 1; ; ++number) {
    const name = `${stem}${number > 1 ? `-${number}` : ""}.${extension}`;
    if (!taken.some((file) => file.name === name)) return name;
  }
}

/**
 * Makes the results for pictures, one after another.
 * @param ask       returns {response, extension} for a picture
 * @param progress  called with the number of pictures that are done
 * @returns         {files, problems}: [{name, blob}], and a text for each picture that failed
 */
export async function resultsFor(pictures, ask, { signal, progress }) {
  const [files, problems] = [[], []];
  for (const [i, picture] of pictures.entries()) {
    progress(i);
    try {
      const { response, extension } = await ask(picture);
      files.push({ name: nameFor(picture, extension, files), blob: await response.blob() });
    } catch (error) {
      signal.throwIfAborted();
      problems.push(`${picture.name}: ${error.message}`);
    }
  }
  return { files, problems };
}
