// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

import java.io.Closeable
import java.util.concurrent.locks.ReentrantReadWriteLock
import kotlin.concurrent.read
import kotlin.concurrent.write

/**
 * Measures one person with one depth camera. Opening loads the models and starts the threads, which takes some tens of
 * milliseconds. [close] frees the session.
 *
 * Threads: any thread may call any function. Calls that change the session, such as [push], run one after another. [progress]
 * and [mask] never wait for them, so the UI thread may call them while frames arrive. [close] waits until other calls have
 * returned. After it, every call throws IllegalStateException.
 *
 * @throws Im2fitException a model is missing, damaged or of another version, or a setting is out of range
 */
class FitSession @JvmOverloads constructor(
    private val camera: CameraModel, models: Models, private val settings: Settings = Settings()
) : Closeable {
    private var handle = open(camera.upright(), models, settings)
    private val open = ReentrantReadWriteLock() // for writing: the handle goes
    private val order = Any() // calls that change the session, one after the other
    private val numbers = IntArray(5)
    private val longs = LongArray(7)
    private val floats = FloatArray(20)

    /** Copies one frame into the session. With [Settings.live] false it waits while the library is behind. */
    fun push(frame: DepthFrame) {
        val of = frame.camera ?: camera
        require(of.rotateDeg == camera.rotateDeg) { "rotateDeg of a frame must be that of its session" }
        frame.checkSize(of.width, of.height)
        change {
            intArrayOf(frame.format.ordinal, of.width, of.height, of.rotateDeg, frame.confidenceMin).copyInto(numbers)
            longs[0] = frame.pixels.position().toLong()
            longs[1] = frame.rowBytes.toLong()
            longs[2] = (frame.confidence?.position() ?: 0).toLong()
            longs[3] = frame.confidenceRowBytes.toLong()
            longs[4] = frame.sequence
            longs[5] = frame.timeNs
            longs[6] = -1
            floats[0] = frame.unitMm
            floats[1] = of.fx
            floats[2] = of.fy
            floats[3] = of.cx
            floats[4] = of.cy
            floats[5] = frame.down?.x ?: 0f
            floats[6] = frame.down?.y ?: 0f
            floats[7] = frame.down?.z ?: 0f
            floats[8] = of.lens.k1
            floats[9] = of.lens.k2
            floats[10] = of.lens.k3
            floats[11] = of.lens.p1
            floats[12] = of.lens.p2
            floats[13] = frame.pose?.x ?: 0f
            floats[14] = frame.pose?.y ?: 0f
            floats[15] = frame.pose?.z ?: 0f
            floats[16] = frame.pose?.w ?: 0f
            floats[17] = frame.pose?.xMm ?: 0f
            floats[18] = frame.pose?.yMm ?: 0f
            floats[19] = frame.pose?.zMm ?: 0f
            Native.push(it, frame.pixels, frame.confidence, numbers, longs, floats)
        }
    }

    /** The latest state of the session. Never waits. */
    fun progress(): Progress = result().progress()

    /**
     * The mask of the person in the latest frame. The session keeps masks after the first call, so the result is null until the
     * next frame. Waits for the copy of one mask at most.
     */
    fun mask(): Mask? = open.read {
        val of = LongArray(5)
        var status = Native.mask(alive(), null, of)
        if (status == NOT_FOUND) return null
        check(status)
        val (width, height) = of.map { it.toInt() }
        val pixels = ByteArray(width * height)
        status = Native.mask(alive(), pixels, of)
        if (status == NOT_FOUND) return null // another thread has reset the session
        check(status)
        Mask(width, height, pixels, of[2].toInt(), of[3], of[4])
    }

    /**
     * The reason why no person is found. It can take some tenths of a second: do not call it for every frame.
     *
     * @param depthMm an upright frame, millimetres, rows of [width] values from the top; unsigned, 0: no data
     */
    fun diagnose(depthMm: ShortArray, width: Int, height: Int): Diagnosis = inOrder { handle ->
        require(depthMm.size.toLong() == width.toLong() * height) { "depthMm has ${depthMm.size} values, expected $width x $height" }
        val numbers = IntArray(2)
        val unit = FloatArray(1)
        val text = Native.diagnose(handle, depthMm, width, height, numbers, unit)
        if (numbers[0] < 0) check(numbers[0])
        Diagnosis(DiagnosisCode.of(numbers[0]), Native.text(text).orEmpty(), unit[0], numbers[1])
    }

    /**
     * Pushes [frames] until the measurement. Yields the progress each time that the display for the person changes. Lazy:
     * frames are taken from the sequence as the result is iterated over.
     */
    fun states(frames: Sequence<DepthFrame>): Sequence<Progress> = sequence {
        var before: Progress? = null
        for (frame in frames) {
            push(frame)
            val now = progress()
            if (now.saysMoreThan(before)) yield(now)
            before = now
            if (now.state == State.MEASURED) break
        }
    }

    /** Passes [states] to [onProgress], then calls [finish]. */
    @JvmOverloads
    fun measure(frames: Sequence<DepthFrame>, onProgress: (Progress) -> Unit = {}): Outcome {
        states(frames).forEach(onProgress)
        return finish()
    }

    /** Waits until all pushed frames are processed. Returns false after [timeoutMs]; negative: no limit. */
    fun await(timeoutMs: Int = -1): Boolean {
        val status = inOrder { Native.act(it, Native.DO_WAIT, timeoutMs) }
        if (status == TIMEOUT) return false
        check(status)
        return true
    }

    /** Ends the stream and measures with the accepted frames. A second call returns the same. */
    fun finish(): Outcome {
        change { Native.act(it, Native.DO_FINISH, 0) }
        return outcome()
    }

    /** The result of [finish]. Also valid when [progress] has the state MEASURED. */
    fun outcome(): Outcome {
        val result = result()
        if (!result.measured) return Outcome.NotMeasured(result.state, result.guidanceSeen)
        return Outcome.Measured(result.person(size()))
    }

    /** Begins a session for a new person and discards all frames. */
    fun reset() = change { Native.act(it, Native.DO_RESET, 0) }

    /** Prepares for the next person, after MEASURED. The next session begins when the measured person has left. */
    fun next() = change { Native.act(it, Native.DO_NEXT, 0) }

    /** From now on, measures only the person with this [Progress.userId]. 0: the first person with empty guidance. */
    fun selectUser(userId: Int) = change { Native.act(it, Native.DO_SELECT_USER, userId) }

    /**
     * From now on, measures only people whose feet are within this rectangle on the floor. Coordinates are relative to the
     * point under the camera: x to the camera's right, z away from it. Without arguments: everywhere.
     */
    @JvmOverloads
    fun setRegion(x0Mm: Float = 0f, z0Mm: Float = 0f, x1Mm: Float = 0f, z1Mm: Float = 0f) =
        change { Native.setRegion(it, floatArrayOf(x0Mm, z0Mm, x1Mm, z1Mm)) }

    /**
     * Sets facts that the person reports, before, during or after the frames. [outcome] then has the changed measurements. A
     * second call replaces the first. [Person.knownDoubted] names facts that contradict the frames and were not used: ask again.
     */
    fun setKnown(known: Known) = change {
        Native.setKnown(it, floatArrayOf(
            known.statureMm, known.statureSdMm, known.weightKg, known.weightSdKg, known.ageYears, known.ageSdYears
        ), known.sex.ordinal)
    }

    /** result.json (docs/result.md), whether measured or not. */
    fun json(): String = String(bytes(Native.BYTES_JSON), Charsets.UTF_8)

    /** The bytes of the person's avatar. Needs a measurement and [Models.body], as do [mesh] and [tape]. */
    fun avatar(format: Avatar): ByteArray = bytes(format.ordinal)

    /** The person as a mesh in the measured pose. */
    fun mesh(): Mesh = inOrder { handle ->
        val counted = IntArray(2)
        check(Native.mesh(handle, null, null, counted))
        val mesh = Mesh(FloatArray(3 * counted[0]), IntArray(3 * counted[1]))
        check(Native.mesh(handle, mesh.vertices, mesh.triangles, counted))
        mesh
    }

    /** Differences between the measurements of [mesh] and the person's: mm, weight in kg. Below 1 mm if such a body exists. */
    fun residual(): Map<Measurement, Float> {
        val values = FloatArray(Measurement.values().size)
        change { Native.residual(it, values) }
        return Measurement.values().associate { it to values[it.ordinal] }
    }

    /** All measurements of the tape, by id, in the order of [tapeDefinitions]. */
    fun tape(): Map<String, TapeValue> {
        val ids = tapeDefinitions().map { it.id }
        val statuses = IntArray(ids.size)
        val values = FloatArray(3 * ids.size)
        val reasons = arrayOfNulls<ByteArray>(ids.size)
        change { Native.tape(it, statuses, values, reasons) }
        return ids.withIndex().associate { (i, id) ->
            id to if (statuses[i] == 0) {
                TapeValue.Measured(Estimate(values[3 * i], values[3 * i + 1], values[3 * i + 2]))
            } else {
                TapeValue.Refused(Native.text(reasons[i]) ?: "")
            }
        }
    }

    /**
     * How each size of a garment, an id of [garments], fits the person. Needs a measurement and [Models.body], as do
     * [dressedAvatar] and [rig].
     */
    fun fit(garment: String): GarmentFit {
        val sizes = arrayOfNulls<ByteArray>(Native.SIZES_MAX)
        val places = arrayOfNulls<ByteArray>(Native.PLACES_MAX)
        val floats = FloatArray(Native.SIZES_MAX * (1 + 3 * Native.PLACES_MAX))
        val verdicts = IntArray(Native.SIZES_MAX * Native.PLACES_MAX)
        val counted = IntArray(3)
        change { Native.fit(it, arrayOf(garment.toByteArray()), sizes, places, floats, verdicts, counted) }
        val (count, best, placeCount) = counted
        val names = (0 until placeCount).map { Native.text(places[it])!! }
        val fits = (0 until count).map { i ->
            val at = i * (1 + 3 * placeCount)
            SizeFit(Native.text(sizes[i])!!, floats[at], names.withIndex().associate { (r, name) ->
                val ease = Estimate(floats[at + 1 + 3 * r], floats[at + 2 + 3 * r], floats[at + 3 + 3 * r])
                name to PlaceFit(ease, Fit.values()[verdicts[i * placeCount + r]])
            })
        }
        return GarmentFit(fits, fits[best])
    }

    /** The person's .glb in clothes. [worn]: innermost first; empty: trousers and a T-shirt of the best sizes. */
    @JvmOverloads
    fun dressedAvatar(worn: List<Worn> = emptyList()): ByteArray {
        require(worn.size <= Native.WORN_MAX) { "${worn.size} garments, expected at most ${Native.WORN_MAX}" }
        val made = arrayOfNulls<ByteArray>(1)
        val ids = Array<ByteArray?>(worn.size) { worn[it].garment.toByteArray() }
        val sizes = Array(worn.size) { worn[it].size?.toByteArray() }
        change { Native.dressed(it, ids, sizes, made) }
        return made[0]!!
    }

    /**
     * The pose of the avatar in the latest frame; null if no person is tracked. It changes after [next], when frames are
     * processed again, until the next session begins.
     */
    fun rig(): Rig? = inOrder { handle ->
        val floats = FloatArray(3 + 4 * Rig.NODE_COUNT)
        val numbers = IntArray(2)
        val status = Native.rig(handle, floats, numbers)
        if (status == NOT_FOUND) return@inOrder null
        check(status)
        Rig(floats.copyOf(3), floats.copyOfRange(3, floats.size), numbers[0], bitsOf(numbers[1].toLong()))
    }

    /** A description of the models that the session was opened with. */
    fun modelInfo(): ModelInfo = inOrder { handle ->
        val n = LongArray(8)
        val texts = arrayOfNulls<ByteArray>(1)
        check(Native.models(handle, n, texts))
        ModelInfo(Native.text(texts[0])!!, n[0], n[1], n[2], n[3] != 0L, n[4] != 0L, n[5] != 0L, n[6] != 0L, n[7] != 0L)
    }

    /** Stops the threads and frees the session. Frames in the pipeline are dropped. A second call does nothing. */
    override fun close() = open.write {
        if (handle != 0L) Native.close(handle)
        handle = 0
    }

    private fun size(): Size {
        val names = arrayOfNulls<ByteArray>(Native.SIZES_MAX)
        val probabilities = FloatArray(Native.SIZES_MAX)
        val counted = IntArray(2)
        change { Native.sizes(it, names, probabilities, counted) }
        val known = (0 until counted[0]).map { Native.text(names[it])!! to probabilities[it] }
        return Size(known[counted[1]].first, known.toMap(LinkedHashMap()))
    }

    private fun bytes(what: Int): ByteArray {
        val made = arrayOfNulls<ByteArray>(1)
        change { Native.bytes(it, what, made) }
        return made[0]!!
    }

    private fun result(): Result = open.read {
        val result = Result()
        check(Native.poll(alive(), result.longs, result.floats))
        result
    }

    private fun alive(): Long = handle.also { check(it != 0L) { "the session is closed" } }
    private inline fun <T> inOrder(what: (Long) -> T): T = open.read { synchronized(order) { what(alive()) } }
    // The text of an error is that of the latest call: read it before another thread calls.
    private inline fun change(what: (Long) -> Int) = inOrder { check(what(it)) }
    private fun check(status: Int) {
        if (status == Native.OK) return
        val text = Native.text(Native.lastError(handle)).orEmpty()
        // Native.poll does not set the handle's text, only the thread's.
        throw Im2fitException(status, if (text != "") text else Native.text(Native.lastError(0)).orEmpty())
    }

    private companion object {
        const val NOT_FOUND = -2
        const val TIMEOUT = -7

        fun open(camera: CameraModel, models: Models, settings: Settings): Long {
            val pack = models.tracker.takeIf { it === models.index && it === models.body }
            val files = if (pack != null) listOf(null, null, null, pack) else listOf(models.tracker, models.index, models.body, null)
            val paths = files.map { (it as? ModelFile.Path)?.file?.path?.toByteArray() } + listOf(null, null)
            val contents = files.map { (it as? ModelFile.Bytes)?.bytes }
            val parts = files.map { it as? ModelFile.Descriptor }
            val numbers = intArrayOf(
                camera.width, camera.height, settings.framesWanted, settings.framesMin, settings.calibrationPose.toInt(),
                settings.live.toInt(), settings.singleThread.toInt(), settings.turn.ordinal, settings.clothing.ordinal,
                settings.sensor.ordinal, 0
            )
            val opened = LongArray(1)
            val status = Native.open(
                paths.toTypedArray(), contents.toTypedArray(), IntArray(4) { parts[it]?.fd ?: -1 },
                LongArray(4) { parts[it]?.offset ?: 0 }, LongArray(4) { parts[it]?.length ?: 0 }, numbers,
                floatArrayOf(camera.fx, camera.fy, camera.cx, camera.cy), opened
            )
            if (status != Native.OK) throw Im2fitException(status, Native.text(Native.lastError(0)).orEmpty())
            return opened[0]
        }

        fun Boolean.toInt(): Int = if (this) 1 else 0
    }
}
