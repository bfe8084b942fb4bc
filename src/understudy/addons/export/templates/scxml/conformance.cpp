// Runs a statechart on the rows of conformance.csv in Qt, and compares what it decides with what Understudy decided:
// conformance-qt $file

#include <QCoreApplication>
#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QScxmlDataModel>
#include <QScxmlStateMachine>
#include <QTextStream>
#include <limits>
#include <memory>

static QByteArray read(const char *name)
{
    QFile file(QString::fromUtf8(name));
    if (!file.open(QIODevice::ReadOnly)) qFatal("%s cannot be read", name);
    return file.readAll();
}

static double parse(const QByteArray &field)
{
    using Double = std::numeric_limits<double>;
    if (field.isEmpty()) return Double::quiet_NaN();
    if (field.endsWith("Infinity")) return field.startsWith('-') ? -Double::infinity() : Double::infinity();
    return field.toDouble(); // in any language of the system
}

static QByteArray join(const QJsonArray &numbers, int added)
{
    QByteArrayList texts;
    for (const QJsonValue &number : numbers) texts += QByteArray::number(number.toInt() + added);
    return texts.join('.');
}

static void send(QScxmlStateMachine &chart, const char *event, const QVariantMap &data)
{
    chart.submitEvent(QString::fromUtf8(event), data);
    QCoreApplication::processEvents();
}

int main(int argc, char **argv)
{
    QCoreApplication application(argc, argv);
    QTextStream out(stdout), problems(stderr);
    const std::unique_ptr<QScxmlStateMachine> chart(QScxmlStateMachine::fromFile(application.arguments().value(1)));
    for (const QScxmlError &error : chart->parseErrors()) problems << error.toString() << Qt::endl;
    if (!chart->parseErrors().isEmpty()) return 1;
    if (!chart->init()) {
        problems << "the statechart cannot begin: its script has an error, or lacks a function" << Qt::endl;
        return 1;
    }
    chart->start();
    QCoreApplication::processEvents();

    const QJsonObject described = QJsonDocument::fromJson(read("states.json")).object();
    const QJsonObject states = described[QLatin1String("states")].toObject();
    const QStringList names = described[QLatin1String("readings")].toVariant().toStringList();
    const QStringList channels = described[QLatin1String("channels")].toVariant().toStringList();
    const QByteArrayList lines = read("conformance.csv").trimmed().split('\n');
    const qsizetype first = 2 + names.size();
    long ticks = 0, mismatches = 0;
    for (qsizetype line = 1; line < lines.size(); line++) {
        const QByteArrayList fields = lines[line].split(',');
        const double now = fields[1].toDouble();
        QVariantMap readings;
        for (qsizetype index = 0; index < names.size(); index++) readings[names[index]] = parse(fields[2 + index]);
        if (fields[0] == "1") send(*chart, "start", {{QStringLiteral("now"), now}});
        send(*chart, "tick", {{QStringLiteral("now"), now}, {QStringLiteral("readings"), readings}});

        const QStringList active = chart->activeStateNames(true);
        const QJsonObject state = states[active.value(0)].toObject();
        bool right = active.size() == 1 && join(state[QLatin1String("path")].toArray(), 0) == fields[first]
            && join(state[QLatin1String("flags")].toArray(), 1) == fields[first + 1]
            && QByteArray::number(state[QLatin1String("basic")].toInt(-1)) == fields[first + 2];
        const QVariantMap commands = chart->dataModel()->scxmlProperty(QStringLiteral("commands")).toMap();
        for (qsizetype index = 0; index < channels.size(); index++)
            right = right && commands[channels[index]].toDouble() == fields[first + 3 + index].toDouble();
        ticks += 1;
        if (!right && ++mismatches <= 5)
            problems << "line " << line + 1 << " of conformance.csv is decided otherwise" << Qt::endl;
    }
    out << ticks << " ticks, " << mismatches << " mismatches" << Qt::endl;
    return mismatches || !ticks ? 1 : 0;
}
