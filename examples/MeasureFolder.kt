// SPDX-License-Identifier: Apache-2.0
// Measures the person in a folder of 16-bit depth pictures (000000.png ..., mm), on any Java virtual machine.
//   kotlinc MeasureFolder.kt -cp /usr/share/java/im2fit.jar -include-runtime -d measure.jar
//   java -cp measure.jar:/usr/share/java/im2fit.jar MeasureFolderKt FOLDER MODELS FX FY CX CY [ROTATE]
// FX FY CX CY: intrinsics of the depth camera, pixels. ROTATE: clockwise rotation that makes its pictures upright, degrees.
// MODELS: the directory where `im2fit models install` has put tracker.i2t, index.i2f and body.i2b.
import im2fit.sdk.CameraModel
import im2fit.sdk.DepthFrame
import im2fit.sdk.FitSession
import im2fit.sdk.Models
import im2fit.sdk.Outcome
import im2fit.sdk.Settings
import java.awt.image.DataBufferUShort
import java.io.File
import javax.imageio.ImageIO
import kotlin.system.exitProcess

class Picture(val width: Int, val height: Int, val depthMm: ShortArray)

fun picture(file: File): Picture {
    val raster = ImageIO.read(file)?.raster
    val samples = raster?.dataBuffer as? DataBufferUShort
    require(samples != null && raster.numBands == 1) { "$file is not a 16-bit grey picture" }
    return Picture(raster.width, raster.height, samples.data)
}

fun main(arguments: Array<String>) {
    if (arguments.size !in 6..7) {
        System.err.println("usage: MeasureFolderKt FOLDER MODELS FX FY CX CY [ROTATE]")
        exitProcess(2)
    }
    val files = File(arguments[0]).listFiles { file -> file.name.endsWith(".png") }.orEmpty().sorted()
    require(files.isNotEmpty()) { "no .png in ${arguments[0]}" }
    val first = picture(files.first())
    val (fx, fy, cx, cy) = arguments.slice(2..5).map { it.toFloat() }
    val camera = CameraModel(first.width, first.height, fx, fy, cx, cy, rotateDeg = arguments.getOrNull(6)?.toInt() ?: 0)

    val frames = files.asSequence().mapIndexed { number, file ->
        DepthFrame.ofMillimetres(picture(file).depthMm, timeNs = number * 1_000_000_000L / 30, sequence = number.toLong())
    }
    // With live = false the session waits for its own threads: no frame of the folder is dropped.
    FitSession(camera, Models.of(File(arguments[1])), Settings(live = false)).use { session ->
        val outcome = session.measure(frames) { println("${it.state} ${it.guidance.joinToString(" ")}") }
        when (outcome) {
            is Outcome.Measured -> for ((measurement, estimate) in outcome.person.measurements)
                println("%-17s %7.1f %s  [%.1f, %.1f]".format(measurement.id, estimate.value, measurement.unit, estimate.low, estimate.high))
            is Outcome.NotMeasured -> {
                println("not measured: ${outcome.guidance.joinToString(" ")}")
                exitProcess(3)
            }
        }
    }
}
